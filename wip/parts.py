import sys
sys.argv=['ver','uc3','7.5,8,7','1','[1]']
exec(open('wip/ver.py').read())
import time
rows=D[(D[:,0]==0)&(D[:,1]==19)]
rng=random.Random(1); tm=Counter(); N=0; calls=Counter()
import certificates.cells as C
for row in rng.sample(list(rows),150):
    c=row[2:16]; y=row[16:22]; N+=1
    t=time.process_time
    t0=t()
    u=[between(rational(float(c[2*k])),rational(float(c[2*k+1])),k) for k in range(3)]
    T=Turned(pf,int(c[6]),u); t1=t(); tm['turned']+=t1-t0
    x=cl.on_branch(T,int(c[7]),1); t2=t(); tm['branch']+=t2-t1
    if x is None: continue
    P=cl.Place(T,x); t3=t(); tm['place']+=t3-t2
    w=T.wrenches(x); t4=t(); tm['wrench']+=t4-t3
    tm['terms']+=sum(len(v) for q in w for v in q)/24e3
    rr=[[number(centre(v)) for v in q] for q in w]; ch=[[[number(z) for z in slopes(v,C.POSE)] for v in q] for q in w]; t5=t(); tm['slopes']+=t5-t4
    P.unbalanced(y); t6=t(); tm['unb incl wr']+=t6-t5
    C.BALANCES=1
    t6=t(); P.unbalanced(y); t7=t(); tm['unb1 incl wr']+=t7-t6
    C.BALANCES=3
print({k:round(v/N*1e3,2) for k,v in tm.items()})
