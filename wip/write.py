import sys, time
from collections import Counter
from fractions import Fraction
from cdpr_interval import load_robot
import solvers.six_dof as sd, solvers.platform_subset as ps
from solvers import forward_kinematics, balls
from solvers.problem import Problem, Options
from solvers.platform_prepared import prepared, lengths_of, kind_of
from solvers.platform_reduction import reduced_problems
from solvers.platform_merge import distinct
from certificates import problem as cp
from certificates.polynomials import rational
from certificates.subsets import classify
from certificates.frames import settings
from certificates.searches import Search
from certificates.tree import Node
from solvers.certificate_tree import Recorder, Known
name,ls=sys.argv[1],sys.argv[2].split(',')
r=load_robot(name); taut=tuple(range(len(ls))) if len(sys.argv)<4 else tuple(map(int,sys.argv[3].split(',')))
keep=[]
orig=ps.SubsetSearch
class Sub(orig):
    def solve(self): super().solve(); keep.append(self)
sd.SubsetSearch=Sub
res=forward_kinematics(r,ls,taut=taut); print(len(res.solutions),'solutions')
L=[(Fraction(x),Fraction(x)) for x in ls]
pr=Problem(r,tuple(L),taut=taut)
q=lambda v:[rational(x) for x in v]
P=cp.Problem(tuple(r.cable_names),[q(c.frame_anchor) for c in r.cables],[q(v) for v in pr.anchors_from_centre],q(r.platform.centre_of_mass),[(rational(a),rational(b)) for a,b in L],[None]*len(L),rational(r.platform.mass),q(r.gravity),q(pr.load),taut,False,False)
from solvers.platform_frame import pose_of
t0=time.time(); c0=time.process_time()
entries=[]
for red,setting,sub in zip(reduced_problems(prepared(pr),lengths_of(pr),Options(),taut),settings(P,taut,classify(P,taut)),keep):
    blank={"order":[taut[k] for k in red.model.orders[0]],"roots":[],"trees":['Ag==' if setting.frozen(c) is not None else None for c in range(4)]}
    blank["trees"]=[None if b is None else 'FQ==' for b in blank["trees"]]
    s=Search(P,setting,blank,99)
    known=[]
    with balls.precision():
        for rt in sub.roots:
            p=pose_of(rt,red.frame)
            ok=[k for k,sol in enumerate(res.solutions) if all(abs(float(a)-b)<1e-6 for a,b in zip([x.mid() for x in p.rotation.entries()],sol.rotation.mean(axis=2).ravel()))]
            print('root',rt.chart,ok,[float(d.mid()) for d in p.densities])
            known.append(Known(rt,ok[0] if ok else None))
    rec=Recorder(red,setting,s,known)
    print('claimed',[(x.chart,x.box[0][1]-x.box[0][0],x.pose) for x in s.roots], time.time()-t0)
    entries.append(rec.entry())
    s2=Search(P,setting,entries[-1],99)
    print(Counter(('x' if l.cell.placed else 'u',l.node.name) for l in s2.leaves), sum(len(t or '') for t in entries[-1]['trees'])*3//4,'bytes', 'write s',round(time.time()-t0,1))
import json; json.dump(entries,open(f'/tmp/p/cert/{name}.json','w'))
import certificates.searches as cs
if len(sys.argv)>6: cs.PIECES=int(sys.argv[6])
BAD=[]
import pickle; pickle.dump((P,taut),open(f'/tmp/p/cert/{name}.pkl','wb')) if 0 else None
def check_all(sample=None):
    import random
    for setting,e in zip(settings(P,taut,classify(P,taut)),entries):
        s=Search(P,setting,e,99)
        t=time.process_time()
        for x in s.roots:
            sy=s.system(x.chart); lo,hi=([b[k] for b in x.box] for k in (0,1))
            a=sy.has_one_zero_at_most(lo,hi); z=sy.zero_near(lo,hi)
            print('root',x.chart,x.pose,a,z is not None and s.pose(x,z).densities.values(), time.process_time()-t)
        lv=s.leaves; 
        if sample and len(lv)>sample: lv=random.Random(1).sample(lv,sample)
        pieces=Counter(); cost=Counter(); num=Counter(); bad=0
        for l in lv:
            t=time.process_time()
            key=('x' if l.cell.placed else 'u')+l.node.name
            try: pieces[min(s.check(l),99)]+=1
            except Exception as e: bad+=1; BAD.append(l); print(type(e),str(e)[:150],l.cell.bounds,l.cell.side)
            cost[key]+=time.process_time()-t; num[key]+=1
        print('pieces',sorted(pieces.items()),'bad',bad,{k:(num[k],round(cost[k]/num[k]*1e3,1)) for k in cost}, 'total',sum(cost.values()))
import flint; flint.ctx.prec=200
check_all(int(sys.argv[4]) if len(sys.argv)>4 else None)
if len(sys.argv)>5 and sys.argv[5]!='0':
    import cProfile,pstats
    s=Search(P,settings(P,taut,classify(P,taut))[-1],entries[-1],99)
    import random
    lv=random.Random(1).sample(s.leaves,min(len(s.leaves),int(sys.argv[5])))
    cProfile.run("for l in lv: s.check(l)",'/tmp/p/prof'); pstats.Stats('/tmp/p/prof').sort_stats('cumtime').print_stats(28)
    from certificates.geometry import Turned
    from certificates.polynomials import between
    import certificates.cells as C
    l=[l for l in lv if l.node.name=='UNBALANCED'][0]
    u=[between(rational(a),rational(b),k) for k,(a,b) in enumerate(l.cell.bounds[:3])]
    T=Turned(s.platform,l.cell.chart,u); x=C.on_branch(T,l.cell.side,1)
    print('terms x',[len(v) for v in x],'w',[[len(v) for v in w] for w in T.wrenches(x)],'len',[len(v) for v in T.lengths(x)])
